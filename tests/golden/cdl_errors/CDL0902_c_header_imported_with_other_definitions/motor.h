typedef int Speed;
