"""The archive: one NeXus HDF5 file a run, and a folder of them."""
