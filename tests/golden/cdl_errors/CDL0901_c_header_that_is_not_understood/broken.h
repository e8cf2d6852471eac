typedef strange Odd;
typedef int Speed;
