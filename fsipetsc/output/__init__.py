"""Result files are written in parallel, read with numpy and h5py alone, described and drawn."""
