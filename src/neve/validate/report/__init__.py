"""Report results as one HTML page with plots."""
