"""What a recorder of the cell gets: the rings that control and video fill, and the process that keeps them."""
