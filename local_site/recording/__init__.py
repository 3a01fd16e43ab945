"""The recorder of the operator's side: what the local site sends, hears and shows, kept by a process of its own."""
