"""How good the sensor is, on cases whose truth is known: the page and pictures of `make accuracy`."""
