typedef short Speed; typedef int Same;
