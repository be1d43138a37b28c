"""The stages of the method, one a file, on one small mesh: `make examples` runs them all and makes a page of pictures."""
