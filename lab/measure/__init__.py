"""Side-by-side measurements of the parts that must be quick; run with make bench."""
