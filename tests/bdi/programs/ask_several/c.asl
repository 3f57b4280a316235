price(apple,5). price(pear,1).
