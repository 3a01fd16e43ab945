"""A process of a site: its life, its children, its pace, what it shares and measures."""
