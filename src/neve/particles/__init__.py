"""Snow as particles in contact: the discrete element method, after Goswami, Markowicz and Hassan 2019."""
