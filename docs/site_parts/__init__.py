"""What the documentation is built with: reference pages made from the program itself, equations, screenshots."""
