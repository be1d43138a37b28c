"""What the names of compressed files end in. A module of its own, as it must load where nothing heavy may."""
SUFFIX = ".npmesh"
