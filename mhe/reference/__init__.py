"""The window problem solved by IPOPT."""
