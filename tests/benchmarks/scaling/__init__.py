"""The scaling study: touch from 2 x 2 to 1024 x 1024 taxels, grids that outgrow the memory, plans on paper."""
