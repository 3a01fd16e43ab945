"""The right to operate: the lease, the clock offset, the remote site's state."""
