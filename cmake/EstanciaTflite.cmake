# filled by label/
