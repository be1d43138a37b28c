"""What the package finds around it when it runs: other packages, and the folder for what is kept between runs."""
