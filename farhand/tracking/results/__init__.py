"""Results of a track: lines, a table, pictures, a video, a report; each takes the pairs as they come."""
