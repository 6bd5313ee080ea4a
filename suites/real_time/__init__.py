"""What a step of the real-time MHE costs on a stream, and what may be saved of it."""
