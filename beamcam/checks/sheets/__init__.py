"""Programs of cutting tables read back and compared with the sheet that they should make."""
