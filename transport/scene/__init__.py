"""The specification of a scene, and its checks: materials, media, sources, emissions, detectors, bins."""
