"""What a user specifies: materials, media, sources, emissions, detectors, bins; a scene, and its checks."""
