"""Result files of studies, and the tables of figures that are written from them."""
