"""The contents of a URDF: its links and joints, where its meshes are, which of it is the arm."""
