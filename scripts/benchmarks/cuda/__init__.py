"""What kernels need on CUDA devices, and how fast they should be there, without one."""
