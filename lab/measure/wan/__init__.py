"""Both sites and the console over an emulated Internet link: following, holds, pictures, against their demands."""
