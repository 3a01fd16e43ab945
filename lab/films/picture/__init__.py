"""From lit surfaces to pictures: cameras, rasterised layers, and what a sensor makes of them."""
