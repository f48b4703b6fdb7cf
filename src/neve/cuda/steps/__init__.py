"""What a step on the GPU needs besides its stages: reports, bodies, and steps without the host."""
