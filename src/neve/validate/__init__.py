"""Validate Neve: experiments with known answers, run through the public interface, and their report."""
