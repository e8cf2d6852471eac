typedef int Speed; typedef int Same;
