"""From lit surfaces to pictures: cameras and rasterised layers."""
