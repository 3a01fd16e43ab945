"""The filmed arm: its mesh posed and moved, its skin, and the person who has it."""
