"""What a URDF says: its links and joints, where its meshes are, which of it is the arm."""
