"""How far float32 arithmetic may move a result, from which every tolerance is derived."""
