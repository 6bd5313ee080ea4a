"""Claims as rows of tables, and what the results say of them."""
