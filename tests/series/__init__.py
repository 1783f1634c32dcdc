"""Tests of ``antires_rs.series``."""
