"""The textured arm grasps and moves a flask before a bookshelf: HAZEL-A and HAZEL-B of the ROBONAUT report."""
