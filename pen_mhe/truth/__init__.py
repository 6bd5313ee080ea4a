"""A truth from elsewhere beside an estimate: clocks and frames aligned, then errors."""
