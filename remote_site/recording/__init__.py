"""Recording of the cell: the rings that control and video fill, and the process that keeps what comes through them."""
