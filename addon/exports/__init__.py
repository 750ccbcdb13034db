"""Files for others: results as tables and pictures, the report, engines."""
