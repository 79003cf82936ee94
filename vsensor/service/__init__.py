"""The daemon: paced, fed and watched; the estimator itself knows nothing of it."""
