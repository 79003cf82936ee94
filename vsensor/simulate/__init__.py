"""The rig that is not there: a string, a speed controller, rock, and sensors with noise."""
