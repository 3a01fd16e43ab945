"""What sites are measured and tested on: their programs, emulated hosts, links, operators; and stepped time."""
