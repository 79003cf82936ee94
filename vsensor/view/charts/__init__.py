"""What an engineer looks at: charts of the string, drawn as lines in a plane or in space."""
