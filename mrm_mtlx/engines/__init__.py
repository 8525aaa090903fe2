"""What can run or compile generated source on this machine. Each engine says whether it is available and why not."""
