"""Does the real-time MHE end where IPOPT ends?"""
