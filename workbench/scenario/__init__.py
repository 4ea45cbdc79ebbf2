"""What is flown, in numbers: scenario files, the table of parameters, excitations."""
