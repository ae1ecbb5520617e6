"""Formation of differential-drive robots under sliding mode control, after Goto, Bertol and Martins."""
