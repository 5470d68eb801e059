"""A camera that leans: how far, by what stands upright in its views, and the views as an upright one has them."""
