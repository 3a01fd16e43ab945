"""Both sites on this machine: started, watched, measured."""
