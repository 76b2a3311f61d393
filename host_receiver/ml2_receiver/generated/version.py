# Generated from pom.xml by config/generate.py.
VERSION = "0.1.0"
