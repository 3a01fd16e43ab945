"""Recorded sessions as videos: H.264 in MP4, of one view or of all in a mosaic."""
