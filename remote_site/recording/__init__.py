"""What a recorder of the cell gets: the ring that control and video fill, its records, and the process that keeps them."""
