"""The picture of what three.js draws of our glTF: `python -m tools.threejs_picture threejs.png`."""
