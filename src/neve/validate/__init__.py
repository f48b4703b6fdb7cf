"""Validate Neve: experiments with known answers, run through the public interface, told in one HTML page."""
