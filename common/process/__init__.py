"""A process of a site: its lifecycle, its children, its scheduling, its metrics."""
