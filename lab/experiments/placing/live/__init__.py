"""The same trials in wall-clock time: both sites, the console and the operator as processes of their own."""
